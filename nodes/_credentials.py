"""What proves to the others who a process is: a folder with certificate, key and authority.

``sceneq secure init`` makes them (docs/security.md). Keys are read by zenoh itself, from the files:
they appear in no message, log, argument or graph file.
"""

import json
import os
import stat
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

VARIABLE = "SCENEQ_CREDENTIALS"
AUTHORITY, CERTIFICATE, KEY, ACCESS = "ca.pem", "cert.pem", "key.pem", "access.json"
SECURE = ("tls/", "quic/")


@dataclass(frozen=True, slots=True)
class Credentials:
    """The files of one process in ``folder``; a router's say also who may do what.

    Raises:
        ValueError: a file is missing, or others may read the key.
    """

    folder: Path

    def __post_init__(self) -> None:
        for name in (AUTHORITY, CERTIFICATE, KEY):
            if not (self.folder / name).is_file():
                raise ValueError(f"credentials: {self.folder / name}: no such file")
        key = self.folder / KEY
        if key.stat().st_mode & _others(key):
            raise ValueError(f"credentials: {key}: others may read it (chmod 600)")

    def link(self) -> dict[str, Any]:
        """Return zenoh's ``transport/link/tls``: both sides show a certificate."""
        return tls_link(self.folder)

    def access(self) -> dict[str, Any]:
        """Return zenoh's ``access_control``; raise ``ValueError`` when the file is unusable."""
        path = self.folder / ACCESS
        try:
            access = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise ValueError(f"credentials: {path}: {error}") from error
        if not isinstance(access, dict) or access.get("default_permission") != "deny":
            raise ValueError(f"credentials: {path}: not made by 'sceneq secure init'")
        return access


def tls_link(folder: Path) -> dict[str, Any]:
    """Return zenoh's ``transport/link/tls`` with the files in ``folder``, there or not."""
    path = {name: str(folder / name) for name in (AUTHORITY, CERTIFICATE, KEY)}
    return {
        "root_ca_certificate": path[AUTHORITY],
        "enable_mtls": True,
        "listen_certificate": path[CERTIFICATE],
        "listen_private_key": path[KEY],
        "connect_certificate": path[CERTIFICATE],
        "connect_private_key": path[KEY],
    }


def _others(key: Path) -> int:
    """Return the permission bits that must not be set.

    systemd and Kubernetes put secrets on a read-only mount for one process, where its group has to
    read them.
    """
    mounted = os.statvfs(key).f_flag & os.ST_RDONLY
    return stat.S_IRWXO if mounted else stat.S_IRWXG | stat.S_IRWXO


def given_credentials(environment: Mapping[str, str] = os.environ) -> Credentials | None:
    """Return those that ``SCENEQ_CREDENTIALS`` names, ``None`` when it names none."""
    folder = environment.get(VARIABLE)
    return Credentials(Path(folder)) if folder else None
