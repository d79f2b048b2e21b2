"""Access rules of a router: who shows which certificate may do what its role grants."""

from collections.abc import Iterable
from typing import Any

from sceneq_tools.security.roles import OF_ONE_SCENE, ROLES, grants


def subject(role: str, scene: str | None = None) -> str:
    """Return the common name of a certificate: the role, of one scene ``client.kitchen``."""
    return role if scene is None else f"{role}.{scene}"


def access_rules(scenes: Iterable[str] = ()) -> dict[str, Any]:
    """Return zenoh's ``access_control``: default deny, one subject per role and scene."""
    subjects: list[tuple[str, str | None]] = [(role, None) for role in ROLES]
    subjects += [(role, scene) for scene in sorted(set(scenes)) for role in OF_ONE_SCENE]
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
            for number, grant in enumerate(grants(role, scene))
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
