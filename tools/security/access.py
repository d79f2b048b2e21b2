"""Access rules of a router: who shows which certificate may do what its role grants."""

from typing import Any

from sceneq_tools.security.roles import OF_ONE_SCENE, ROLES, grants
from sceneq_tools.security.site import Site


def subject(role: str, scene: str | None = None) -> str:
    """Return the common name of a certificate: the role, of one scene ``client.kitchen``."""
    return role if scene is None else f"{role}.{scene}"


def access_rules(site: Site) -> dict[str, Any]:
    """Return zenoh's ``access_control``: default deny, one subject per role and scene.

    A role without a grant, as that of ROS without topics, is no subject: it is denied as strangers
    are.
    """
    possible: list[tuple[str, str | None]] = [(role, None) for role in ROLES]
    possible += [(role, scene) for scene in sorted(set(site.scenes)) for role in OF_ONE_SCENE]
    subjects = [one for one in possible if grants(*one, site.ros)]
    rules, policies = [], []
    for role, scene in subjects:
        name = subject(role, scene)
        granted = [
            {
                "id": f"{name} {number}",
                "permission": "allow",
                "flows": list(grant.flows),
                "messages": list(grant.messages),
                "key_exprs": list(grant.keys),
            }
            for number, grant in enumerate(grants(role, scene, site.ros))
        ]
        rules += granted
        policies.append({"rules": [rule["id"] for rule in granted], "subjects": [name]})
    names = [subject(*one) for one in subjects]
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": [{"id": name, "cert_common_names": [name]} for name in names],
        "policies": policies,
    }
