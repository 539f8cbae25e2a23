"""The recipe for nginx in docs/network.md, as it stands there: with TLS, at a path of its own."""

from __future__ import annotations

import json
import re
import shutil
import socket
import ssl
import subprocess
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import httpx
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from tests.server.test_launch import served

NGINX = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin:/usr/local/sbin")
OPENSSL = shutil.which("openssl")
NAME = "lab.example.edu"
TOKEN = "a-token-of-thirty-two-letters-at-least"
PAGE = Path(__file__).parents[2] / "docs" / "network.md"

pytestmark = pytest.mark.skipif(
    NGINX is None or OPENSSL is None, reason="nginx and openssl are not installed"
)


class Proxy(NamedTuple):
    """An nginx before a console."""

    port: int
    trust: ssl.SSLContext

    @property
    def host(self) -> str:
        return f"{NAME}:{self.port}"

    def asked(self, method: str, path: str, **more: Any) -> httpx.Response:
        """A request to the name, which is this computer."""
        headers = {"Host": self.host, **more.pop("headers", {})}
        with httpx.Client(verify=self.trust) as client:
            return client.request(
                method,
                f"https://127.0.0.1:{self.port}{path}",
                headers=headers,
                extensions={"sni_hostname": NAME},
                **more,
            )


def recipe(port: int) -> str:
    """The block of the document, for a console at this port."""
    block = re.search(r"```nginx\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert block is not None and "http://127.0.0.1:8000/" in block[1]
    return block[1].replace("127.0.0.1:8000", f"127.0.0.1:{port}")


def free_port() -> int:
    with closing(socket.socket()) as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def certificate(folder: Path) -> None:
    subprocess.run(
        [
            *(str(OPENSSL), "req", "-x509", "-newkey", "ec", "-pkeyopt"),
            *("ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj", f"/CN={NAME}"),
            *("-addext", f"subjectAltName=DNS:{NAME}", "-keyout", "key.pem", "-out", "cert.pem"),
        ],
        cwd=folder,
        check=True,
        capture_output=True,
    )


@contextmanager
def proxied(folder: Path, console: int) -> Iterator[Proxy]:
    certificate(folder)
    port = free_port()
    (folder / "nginx.conf").write_text(
        "daemon off; master_process off; pid nginx.pid; error_log error.log;\n"
        "events {}\n"
        "http { access_log off; client_body_temp_path t1; proxy_temp_path t2;\n"
        "fastcgi_temp_path t3; uwsgi_temp_path t4; scgi_temp_path t5;\n"
        f"server {{ listen 127.0.0.1:{port} ssl; server_name {NAME};\n"
        f"ssl_certificate cert.pem; ssl_certificate_key key.pem;\n{recipe(console)}}} }}\n",
        "utf-8",
    )
    command = [str(NGINX), "-p", str(folder), "-e", "error.log", "-c", str(folder / "nginx.conf")]
    with subprocess.Popen(command, stderr=subprocess.PIPE) as process:
        try:
            _until_open(port)
            yield Proxy(port, ssl.create_default_context(cafile=str(folder / "cert.pem")))
        finally:
            process.terminate()


def _until_open(port: int) -> None:
    for _ in range(200):
        with closing(socket.socket()) as found:
            if found.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.05)
    raise AssertionError("nginx does not listen")


@pytest.fixture(scope="module")
def proxy(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Proxy]:
    folder = tmp_path_factory.mktemp("proxy")
    options = ("--token", TOKEN, "--allow-host", NAME)
    with served(folder / "data", *options) as (_, url):
        port = int(re.findall(r":(\d+)", url)[0])
        with proxied(folder, port) as found:
            yield found


def cookie(proxy: Proxy) -> str:
    """What the browser keeps after the printed address was opened below the path."""
    answer = proxy.asked("GET", f"/console/login?token={TOKEN}")
    assert answer.is_redirect
    assert "path=/;" not in answer.headers["set-cookie"].lower().replace(" ", "")
    return str(answer.headers["set-cookie"]).split(";")[0]


def test_the_page_its_scripts_and_the_canvas_are_there_below_the_path(proxy: Proxy) -> None:
    known = {"Cookie": cookie(proxy)}
    page = proxy.asked("GET", "/console/", headers=known)
    assert page.status_code == 200
    named = re.findall(r'(?:src|href)="([^"#]+\.(?:js|css|svg))"', page.text)
    assert named and not any(name.startswith("/") for name in named)
    for name in named:
        assert proxy.asked("GET", f"/console/{name}", headers=known).status_code == 200
    assert proxy.asked("GET", "/console/view/", headers=known).status_code in (200, 307)


def test_a_page_of_that_name_drives_and_one_of_another_does_not(proxy: Proxy) -> None:
    known = {"Cookie": cookie(proxy)}
    ours = {**known, "Origin": f"https://{proxy.host}"}
    assert proxy.asked("POST", "/console/api/v1/console/reset", headers=ours).is_success
    theirs = {**known, "Origin": "https://evil.example"}
    assert proxy.asked("POST", "/console/api/v1/console/reset", headers=theirs).status_code == 403
    nobody = proxy.asked("POST", "/console/api/v1/console/reset", headers={"Host": proxy.host})
    assert nobody.status_code == 401


def drive(proxy: Proxy, origin: str, known: str) -> str:
    """The first frame of the socket through the proxy."""
    sock = socket.create_connection(("127.0.0.1", proxy.port))
    with connect(
        f"wss://{proxy.host}/console/drive",
        sock=sock,
        ssl=proxy.trust,
        origin=origin,  # type: ignore[arg-type]
        additional_headers={"Cookie": known},
    ) as opened:
        return str(json.loads(opened.recv())["type"])


def test_the_socket_passes_through_for_our_own_page_alone(proxy: Proxy) -> None:
    known = cookie(proxy)
    assert drive(proxy, f"https://{proxy.host}", known) == "hello"
    with pytest.raises(InvalidStatus):
        drive(proxy, "https://evil.example", known)


def test_a_name_that_was_not_allowed_stays_out(proxy: Proxy) -> None:
    answer = proxy.asked("GET", "/console/", headers={"Host": f"other.example:{proxy.port}"})
    assert answer.status_code == 403
