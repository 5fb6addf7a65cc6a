"""A certificate of our own, since browsers give motion over HTTPS only; phones ask whether to trust it."""

from __future__ import annotations

import datetime
import ipaddress
import os
from pathlib import Path

import platformdirs

from kinetograph.errors import RequestError

_DAYS = 365


def certificate(host: str) -> Path:
    """The file with the certificate and its key for an address; made at its first use, and anew when it has ended.

    Parameters
    ----------
    host : str
        Name or address that phones open.

    Returns
    -------
    Path

    Raises
    ------
    RequestError
        Without the extra.
    """
    try:
        from cryptography import x509
        from cryptography.hazmat.primitives import hashes, serialization
        from cryptography.hazmat.primitives.asymmetric import ec
    except ImportError:
        raise RequestError("HTTPS needs the extra 'live': pip install 'kinetograph[live]'") from None
    plain = "".join(letter if letter.isalnum() else "-" for letter in host)[:80]
    path = Path(platformdirs.user_data_dir("kinetograph")) / f"phone-{plain}.pem"
    now = datetime.datetime.now(datetime.UTC)
    if path.exists() and x509.load_pem_x509_certificate(path.read_bytes()).not_valid_after_utc > now:
        return path
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "Kinetograph on this machine")])
    try:
        reached: x509.GeneralName = x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        reached = x509.DNSName(host)
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=_DAYS))
        .add_extension(x509.SubjectAlternativeName([reached]), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )
    secret = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_suffix(f".{os.getpid()}")
    with open(os.open(draft, os.O_CREAT | os.O_TRUNC | os.O_WRONLY, 0o600), "wb") as file:
        file.write(made.public_bytes(serialization.Encoding.PEM) + secret)
    os.replace(draft, path)
    return path
