"""The target in a picture and the camera, and the words for a look."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.capability.word import Word

Degrees = Annotated[float, Meta(ge=0.0, le=360.0)]
Percent = Annotated[float, Meta(ge=0.0, le=100.0)]

MODEL_HINT = (
    "download face_detection_yunet_2026may.onnx (for OpenCV 4: 2023mar) from OpenCV's model zoo, "
    "github.com/opencv/opencv_zoo, models/face_detection_yunet, and name the file in the setting `face_model`"
)


class VisionSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The target and the camera; the colour is that of an orange ball, as hue, saturation and value.

    A hue from 350 to 10 goes over red.
    """

    hue_deg: tuple[Degrees, Degrees] = (6.0, 32.0)
    saturation_percent: tuple[Percent, Percent] = (60.0, 100.0)
    value_percent: tuple[Percent, Percent] = (40.0, 100.0)
    field_deg: Annotated[float, Meta(gt=1.0, le=170.0, description="how wide the camera sees")] = 60.0
    max_age_s: Annotated[float, Meta(gt=0.0, le=5.0, description="an older picture does not count")] = 0.5
    face_model: Annotated[str, Meta(description="a file with a YuNet model (ONNX); empty: colours only")] = ""


LOOK_WORDS = (
    Word("look", "look", "Save the picture with the coloured thing marked, and report the colour of its middle"),
    Word("/look/{target}", "look", "Save the picture with that marked: colour or face"),
)
