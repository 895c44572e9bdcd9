"""Debian's broker of MQTT for tests: with certificates of its own on loopback, killed and started again at the same port."""

import datetime as dt
import ipaddress
import signal
import ssl
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID
from paho.mqtt import client as mqtt

from tests.support import programs
from tests.support.robot import free_port
from tests.support.waiting import until

CONFIG = """
listener {port} 127.0.0.1
user root
persistence false
log_dest none
cafile {folder}/ca.crt
certfile {folder}/broker.crt
keyfile {folder}/broker.key
require_certificate true
use_identity_as_username true
allow_anonymous false
max_packet_size 1000000
"""


def certificates(folder: Path, *names: str) -> None:
    """Write an authority, and for each name a certificate by it and its key; `broker` is for this machine."""
    folder.mkdir(parents=True, exist_ok=True)
    authority = ec.generate_private_key(ec.SECP256R1())
    issuer = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "authority of a test")])
    _write(folder / "ca", authority, _signed(issuer, issuer, authority, authority, ca=True))
    for name in names:
        key = ec.generate_private_key(ec.SECP256R1())
        subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
        _write(folder / name, key, _signed(subject, issuer, key, authority, ca=False))


def _signed(subject: x509.Name, issuer: x509.Name, key: Any, by: Any, *, ca: bool) -> x509.Certificate:
    now = dt.datetime.now(dt.UTC)
    names = [x509.DNSName("localhost"), x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]
    identity = x509.SubjectKeyIdentifier.from_public_key(by.public_key())
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - dt.timedelta(days=1))
        .not_valid_after(now + dt.timedelta(days=2))
        .add_extension(x509.BasicConstraints(ca=ca, path_length=None), critical=True)
        .add_extension(x509.SubjectAlternativeName(names), critical=False)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_subject_key_identifier(identity), critical=False)
        .sign(by, hashes.SHA256())
    )


def _write(path: Path, key: Any, certificate: x509.Certificate) -> None:
    path.with_suffix(".key").write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
    path.with_suffix(".key").chmod(0o600)
    path.with_suffix(".crt").write_bytes(certificate.public_bytes(Encoding.PEM))


class Mosquitto:
    """The broker, with certificates in `folder`; who comes in has one of them, and may what lines of `rights` say, or all."""

    def __init__(self, folder: Path, rights: str = "") -> None:
        self.folder = folder
        self.port = free_port()
        self._config = folder / f"mosquitto-{self.port}.conf"
        config = CONFIG.format(port=self.port, folder=folder)
        if rights:
            allowed = folder / f"mosquitto-{self.port}.acl"
            allowed.write_text(f"user robot\n{rights}\n")
            allowed.chmod(0o600)
            config += f"acl_file {allowed}\n"
        self._config.write_text(config)
        self._popen: Any = None

    def start(self) -> None:
        self._popen = programs.start(["mosquitto", "-c", self._config])

    def freeze(self) -> None:
        """Have it stand still, with whoever is connected."""
        self._popen.send_signal(signal.SIGSTOP)

    def thaw(self) -> None:
        self._popen.send_signal(signal.SIGCONT)

    def kill(self) -> None:
        if self._popen is not None:
            self._popen.kill()
            self._popen.wait()
            self._popen = None


class Person:
    """Somebody at the broker, who hears `topics` and keeps what was said there, oldest first; goes on after its loss."""

    def __init__(self, broker: Mosquitto, name: str, *topics: str, certificate: str = "") -> None:
        self.heard: list[tuple[float, str, bytes, bool]] = []
        self.hear: Callable[[str, bytes], None] = lambda _topic, _payload: None
        self._ready = threading.Event()
        self._topics = topics
        self.client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, client_id=name, protocol=mqtt.MQTTv5)
        context = ssl.create_default_context(cafile=str(broker.folder / "ca.crt"))
        context.verify_flags &= ~ssl.VERIFY_X509_STRICT
        given = broker.folder / (certificate or name)
        context.load_cert_chain(given.with_suffix(".crt"), given.with_suffix(".key"))
        self.client.tls_set_context(context)
        self.client.reconnect_delay_set(1, 1)
        self.client.on_connect = lambda client, *_: client.subscribe([(topic, 1) for topic in topics])
        self.client.on_subscribe = lambda *_: self._ready.set()
        self.client.on_message = self._on_message
        until(lambda: _connects(self.client, broker.port), what="the broker")
        self.client.loop_start()
        until(self._ready.is_set, what="its subscriptions")

    def say(self, topic: str, payload: str | bytes, *, retain: bool = False) -> None:
        self.client.publish(topic, payload, qos=1, retain=retain).wait_for_publish(5.0)

    def on(self, topic: str, since: int = 0) -> list[bytes]:
        """Return what was said there, after so many messages."""
        return [payload for _at, where, payload, _kept in self.heard[since:] if where == topic]

    def times(self, topic: str) -> list[float]:
        return [at for at, where, _payload, _kept in self.heard if where == topic]

    def close(self) -> None:
        self.client.disconnect()
        self.client.loop_stop()

    def _on_message(self, _client: Any, _data: Any, message: Any) -> None:
        self.heard.append((time.monotonic(), message.topic, message.payload, message.retain))
        self.hear(message.topic, message.payload)


def _connects(client: mqtt.Client, port: int) -> bool:
    try:
        return client.connect("localhost", port, keepalive=30) == mqtt.MQTT_ERR_SUCCESS
    except OSError:
        return False
