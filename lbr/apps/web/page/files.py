"""The built files of the page, and how they are served: media types, compression, and caching by browsers."""

import gzip
import mimetypes
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from hashlib import sha256
from importlib import resources
from importlib.resources.abc import Traversable

import msgspec
from starlette.responses import Response

from lbr.apps.web.face import HTML, JSON, Face, Refused, Request, Route, declared, get
from lbr.apps.web.guards import SECURITY
from lbr.apps.web.robot import Robot
from lbr.messages.unreadable import UNREADABLE

FOREVER = "public, max-age=31536000, immutable"
"""For files whose names change with their content."""
LOOK_AGAIN = "no-cache"
ASSETS = "assets/"
INDEX, MANIFEST = "index.html", "manifest.json"
MEDIA = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".ico": "image/x-icon",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".md": "text/markdown; charset=utf-8",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".webmanifest": "application/manifest+json",
    ".woff2": "font/woff2",
}
POLICY = SECURITY["content-security-policy"] + "; manifest-src 'self'; worker-src 'self'; media-src 'self'"
"""Only scripts, styles and pictures from this server are allowed, and none within the page's text."""
TOO_SMALL = 512
"""The size below which a file is not compressed."""


class NotBuiltError(RuntimeError):
    """The page was not built."""


@dataclass(frozen=True, slots=True)
class File:
    """A built file: `packed` if compression makes it smaller, else `plain`; `tag` is its ETag."""

    name: str
    media: str
    plain: bytes
    packed: bytes
    tag: str

    @property
    def lasts(self) -> bool:
        """Return whether its name changes with its content."""
        return self.name.startswith(ASSETS)


def built(place: Traversable | None = None) -> tuple[File, ...]:
    """Return all files of `dist/`; raise NotBuiltError without a page."""
    place = place or resources.files(__package__) / "dist"
    files = tuple(file(name, content) for name, content in _read(place)) if place.is_dir() else ()
    if not any(one.name == INDEX for one in files):
        raise NotBuiltError(
            f"the page is not built: {place}/{INDEX} is missing; `make page` builds it (node 20 or newer)"
        )
    return files


def face(_robot: Robot) -> "PageFace":
    """Return the face."""
    return PageFace(built())


class _Manifest(msgspec.Struct):
    """The manifest of the build."""

    sources: str


def build(place: Traversable | None = None) -> str:
    """Return the name of the built page, which the page itself also knows; empty if it is not built."""
    kept = (place or resources.files(__package__) / "dist") / MANIFEST
    try:
        return msgspec.json.decode(kept.read_bytes(), type=_Manifest).sources[:16]
    except (OSError, *UNREADABLE):
        return ""


def file(name: str, content: bytes) -> File:
    """Return a file to serve; compressed if that makes it smaller."""
    suffix = f".{name.rpartition('.')[2]}"
    media = MEDIA.get(suffix) or mimetypes.guess_type(name)[0] or "application/octet-stream"
    packed = gzip.compress(content, 6, mtime=0) if len(content) >= TOO_SMALL else b""
    smaller = packed if len(packed) < 0.9 * len(content) else b""
    return File(name, media, b"" if smaller else content, smaller, f'"{sha256(content).hexdigest()[:32]}"')


def _read(place: Traversable, under: str = "") -> Iterator[tuple[str, bytes]]:
    for path in sorted(place.iterdir(), key=lambda path: path.name):
        if path.is_dir():
            yield from _read(path, f"{under}{path.name}/")
        else:
            yield under + path.name, path.read_bytes()


class PageFace(Face):
    """Serves the page to every client: it holds no data of the robot, and requests all it shows."""

    name = "page"

    def __init__(self, files: Iterable[File]) -> None:
        self._files = {one.name: one for one in files}

    def routes(self) -> list[Route]:
        """Return the routes of the page at `/` for browsers, of the files beside it, and of the assets."""
        beside = [one.name for one in self._files.values() if not one.lasts and one.name not in {INDEX, MANIFEST}]
        parts = [Route(method="GET", path=f"/{name}", handle=self._of(name), role=None, page=True) for name in beside]
        return [*declared(self), *parts]

    def _of(self, name: str) -> Callable[[Request], Response]:
        return lambda request: served(self._files[name], request)

    @get("/", role=None, page=True, accept=HTML)
    @get("/display", role=None, page=True)
    def _index(self, request: Request) -> Response:
        return served(self._files[INDEX], request)

    @get(f"/{ASSETS}{{name}}", role=None, page=True)
    def _asset(self, request: Request, name: str) -> Response:
        file = self._files.get(ASSETS + name)
        if file is None:
            raise Refused(404, "this page is of another version: load it again")
        return served(file, request)


def served(file: File, request: Request) -> Response:
    """Return a file, or 304 if the browser has it."""
    headers = {
        "Cache-Control": FOREVER if file.lasts else LOOK_AGAIN,
        "ETag": file.tag,
        "Vary": "Origin, Accept, Accept-Encoding",
    }
    if file.name == INDEX:
        headers["Content-Security-Policy"] = POLICY
    known = [tag.strip().removeprefix("W/") for tag in request.headers.get("if-none-match", "").split(",")]
    if file.tag in known:
        return Response(status_code=304, headers=headers)
    if file.packed and takes_gzip(request.headers.get("accept-encoding", "")):
        return Response(file.packed, headers={**headers, "Content-Encoding": "gzip"}, media_type=file.media)
    return Response(file.plain or gzip.decompress(file.packed), headers=headers, media_type=file.media)


def pack(answer: Response) -> None:
    """Compress a large JSON response."""
    if (answer.media_type or "").startswith(JSON) and len(answer.body) >= TOO_SMALL:
        answer.body = gzip.compress(answer.body, 1, mtime=0)
        answer.headers.update({"Content-Encoding": "gzip", "Content-Length": str(len(answer.body))})


def takes_gzip(encodings: str) -> bool:
    """Return whether an `Accept-Encoding` allows gzip."""
    for part in encodings.lower().split(","):
        name, _, weight = part.partition(";")
        if name.strip() in {"gzip", "*"}:
            return weight.replace(" ", "") not in {"q=0", "q=0.0", "q=0.00", "q=0.000"}
    return False
