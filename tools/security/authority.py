"""A certificate authority of one's own: one folder, kept where the router's owner keeps keys."""

import ipaddress
import os
from collections.abc import Iterable
from datetime import datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from sceneq_nodes._credentials import AUTHORITY, CERTIFICATE, KEY

AUTHORITY_DAYS = 3650
CLOCK_SKEW = timedelta(hours=1)
"""A robot's clock may be behind: what was made now is valid for it too."""
AUTHORITY_KEY = "ca.key.pem"


class Authority:
    """Signs certificates; ``create`` makes one in an empty folder, ``open`` reads it.

    Keys are ECDSA on P-256; key files are readable by their owner only, from their first byte on.
    """

    def __init__(self, key: ec.EllipticCurvePrivateKey, certificate: x509.Certificate) -> None:
        self._key = key
        self._certificate = certificate

    @staticmethod
    def create(folder: Path, now: datetime) -> "Authority":
        """Make an authority in ``folder``; raise ``FileExistsError`` when there is one."""
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        key = ec.generate_private_key(ec.SECP256R1())
        name, public = _name("sceneq authority"), key.public_key()
        builder = _builder(name, name, public, public, now, AUTHORITY_DAYS).add_extension(
            x509.BasicConstraints(ca=True, path_length=0), critical=True
        )
        usage = _usage(key_cert_sign=True, crl_sign=True, digital_signature=False)
        certificate = builder.add_extension(usage, critical=True).sign(key, hashes.SHA256())
        _write_private(folder / AUTHORITY_KEY, _key_bytes(key))
        (folder / AUTHORITY).write_bytes(_pem(certificate))
        return Authority(key, certificate)

    @staticmethod
    def open(folder: Path) -> "Authority":
        """Return the authority in ``folder``.

        Raises:
            OSError: a file that cannot be read.
            ValueError: one that is no key or certificate.
        """
        key = serialization.load_pem_private_key(
            (folder / AUTHORITY_KEY).read_bytes(), password=None
        )
        if not isinstance(key, ec.EllipticCurvePrivateKey):
            raise ValueError(f"{folder / AUTHORITY_KEY}: not a key on an elliptic curve")
        certificate = x509.load_pem_x509_certificate((folder / AUTHORITY).read_bytes())
        return Authority(key, certificate)

    def issue(
        self,
        folder: Path,
        subject: str,
        holder: str,
        hosts: Iterable[str],
        now: datetime,
        days: int,
    ) -> None:
        """Write certificate, key and authority of ``subject`` into ``folder``, mode 0700.

        ``holder`` says for whom it is; ``hosts`` are the names and addresses it may answer at.

        Raises:
            FileExistsError: the folder has a key already.
        """
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        key = ec.generate_private_key(ec.SECP256R1())
        _write_private(folder / KEY, _key_bytes(key))
        uses = [ExtendedKeyUsageOID.CLIENT_AUTH, ExtendedKeyUsageOID.SERVER_AUTH]
        names = _name(subject, holder), self._certificate.subject
        keys = key.public_key(), self._key.public_key()
        builder = (
            _builder(*names, *keys, now, days)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(_usage(), critical=True)
            .add_extension(x509.ExtendedKeyUsage(uses), critical=False)
        )
        if answering := [_alternative(host) for host in hosts]:
            builder = builder.add_extension(x509.SubjectAlternativeName(answering), critical=False)
        certificate = builder.sign(self._key, hashes.SHA256())
        (folder / CERTIFICATE).write_bytes(_pem(certificate))
        (folder / AUTHORITY).write_bytes(_pem(self._certificate))


def _builder(
    subject: x509.Name,
    issuer: x509.Name,
    public_key: ec.EllipticCurvePublicKey,
    signer: ec.EllipticCurvePublicKey,
    now: datetime,
    days: int,
) -> x509.CertificateBuilder:
    """Return what every certificate says.

    ``signer`` verifies it. Both key identifiers are demanded by RFC 5280, and by Python from 3.13.
    """
    signed_by = x509.AuthorityKeyIdentifier.from_issuer_public_key(signer)
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(public_key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - CLOCK_SKEW)
        .not_valid_after(now + timedelta(days=days))
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(public_key), critical=False)
        .add_extension(signed_by, critical=False)
    )


def _name(common: str, unit: str = "") -> x509.Name:
    parts = [x509.NameAttribute(NameOID.COMMON_NAME, common)]
    if unit:
        parts.append(x509.NameAttribute(NameOID.ORGANIZATIONAL_UNIT_NAME, unit))
    return x509.Name(parts)


def _usage(
    *, digital_signature: bool = True, key_cert_sign: bool = False, crl_sign: bool = False
) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=digital_signature,
        key_cert_sign=key_cert_sign,
        crl_sign=crl_sign,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        encipher_only=False,
        decipher_only=False,
    )


def _alternative(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        return x509.DNSName(host)


def _key_bytes(key: ec.EllipticCurvePrivateKey) -> bytes:
    return key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )


def _pem(certificate: x509.Certificate) -> bytes:
    return certificate.public_bytes(serialization.Encoding.PEM)


def _write_private(path: Path, content: bytes) -> None:
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "wb") as file:
        file.write(content)
