"""A drawing surface without a screen, by EGL; through ctypes, so that it needs only Mesa's libraries."""

import ctypes
from ctypes import c_char_p, c_int, c_uint, c_void_p
from typing import Any

from lbr.errors import LbrError

_SURFACELESS_MESA, _OPENGL_API = 0x31DD, 0x30A2
_ATTRIBUTES = (
    *(0x3024, 8, 0x3023, 8, 0x3022, 8),  # red, green, blue
    *(0x3025, 24),  # depth
    *(0x3033, 0x0001),  # surfaces: pixel buffers
    *(0x3040, 0x0008),  # renderable: OpenGL
    0x3038,
)


class EglContext:
    """OpenGL for this thread; raises LbrError if the machine has none."""

    def __init__(self) -> None:
        try:
            self._egl = ctypes.CDLL("libEGL.so.1", ctypes.RTLD_GLOBAL)  # MuJoCo searches there for its functions
        except OSError as err:
            raise LbrError(f"no EGL here ({err}); Debian has it in libegl1 and libgl1-mesa-dri") from err
        self._display = self._opened()
        self._context = self._made()

    def close(self) -> None:
        """Release it."""
        self._call("eglMakeCurrent", c_int, (c_void_p,) * 4, self._display, None, None, None)
        self._call("eglDestroyContext", c_int, (c_void_p, c_void_p), self._display, self._context)
        self._call("eglTerminate", c_int, (c_void_p,), self._display)

    def _opened(self) -> int:
        address = self._call("eglGetProcAddress", c_void_p, (c_char_p,), b"eglGetPlatformDisplayEXT")
        candidates = [self._call("eglGetDisplay", c_void_p, (c_void_p,), None)]
        if address:
            platform = ctypes.CFUNCTYPE(c_void_p, c_uint, c_void_p, c_void_p)(address)
            candidates.insert(0, platform(_SURFACELESS_MESA, None, None))
        for display in candidates:
            if display and self._call("eglInitialize", c_int, (c_void_p,) * 3, display, None, None):
                return int(display)
        raise LbrError("EGL has no display to draw on")

    def _made(self) -> int:
        config, count = c_void_p(), c_int()
        chosen = self._call(
            "eglChooseConfig",
            c_int,
            (c_void_p, c_void_p, c_void_p, c_int, c_void_p),
            self._display,
            (c_int * len(_ATTRIBUTES))(*_ATTRIBUTES),
            ctypes.byref(config),
            1,
            ctypes.byref(count),
        )
        if not chosen or not count.value:
            raise LbrError("EGL has no configuration with colours and depth")
        self._call("eglBindAPI", c_int, (c_uint,), _OPENGL_API)
        context = self._call("eglCreateContext", c_void_p, (c_void_p,) * 4, self._display, config, None, None)
        if not context:
            raise LbrError("EGL makes no OpenGL context")
        if not self._call("eglMakeCurrent", c_int, (c_void_p,) * 4, self._display, None, None, context):
            raise LbrError("EGL cannot draw without a surface here")
        return int(context)

    def _call(self, name: str, result: Any, kinds: tuple[Any, ...], *values: Any) -> Any:
        function = getattr(self._egl, name)
        function.restype, function.argtypes = result, kinds
        return function(*values)
