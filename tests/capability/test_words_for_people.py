"""What may have been meant, and what a program's row may say: whatever is typed, an answer comes, and a short one."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.capability.program import KIND, ProgramSettings


@pytest.mark.parametrize(
    ("settings", "where"),
    [
        ("{}", "argv"),
        ('{"argv": []}', "argv"),
        ('{"argv": "sleep 5"}', "argv"),
        ('{"argv": ["a\\u0000b"]}', "argv"),
        ('{"argv": [""]}', "argv"),
        ('{"argv": ["a"], "inputs": ["Big"]}', "inputs"),
        ('{"argv": ["a"], "outputs": ["../up"]}', "outputs"),
        ('{"argv": ["a"], "commands": ["a b"]}', "commands"),
        ('{"argv": ["a"], "env": {"A=B": "c"}}', "env"),
        ('{"argv": ["a"], "env": {"A": "b\\u0000"}}', "env"),
        ('{"argv": ["a"], "env": {"": "b"}}', "env"),
        ('{"argv": ["a"], "ready": "soon"}', "ready"),
        ('{"argv": ["a"], "shell": true}', "shell"),
    ],
)
def test_a_program_that_no_system_can_start_is_refused_with_the_field(settings, where):
    with pytest.raises(msgspec.ValidationError, match=where):
        KIND.parse(settings)


@pytest.mark.parametrize("name", ["inputs", "outputs", "commands"])
@pytest.mark.parametrize("port", ["a\n", "a\n\n", "\na", "a\u2028", "a\u0661"])
def test_no_line_break_or_foreign_digit_comes_into_a_key_of_the_bus(name, port):
    with pytest.raises(msgspec.ValidationError):
        KIND.parse(msgspec.json.encode({"argv": ["a"], name: [port]}))


@given(st.text(max_size=12), st.text(max_size=12))
def test_what_a_program_gets_in_its_environment_a_system_can_set(name, value):
    try:
        env = msgspec.convert({"argv": ["a"], "env": {name: value}}, ProgramSettings).env
    except msgspec.ValidationError:
        return
    for one, said in env.items():
        assert one.isidentifier()
        assert one.isascii()
        assert "\n" not in one
        assert "\x00" not in said
