"""A graph as files for other machines: systemd units, Kubernetes manifests, compose files."""
