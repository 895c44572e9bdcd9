"""Tokens: what was printed is read, what was not is refused without being repeated, and only its own hash fits a secret."""

import secrets

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.bus import tokens
from lbr.errors import InputError

LETTERS = "ABCXYZabcxyz0129-_"
named = st.from_regex(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}", fullmatch=True)
SECRET, PRINT = "s" * 43, "f" * 22


@given(named, st.text(LETTERS, min_size=43, max_size=43), st.text(LETTERS, min_size=22, max_size=22))
def test_what_is_printed_is_read_also_with_blanks_around(name, secret, fingerprint):
    token = tokens.Token(name=name, secret=secret, fingerprint=fingerprint)
    assert tokens.parse(f" {token}\n") == token
    assert (token.credentials.user, token.credentials.password) == (name, secret)


@given(st.text(max_size=120))
def test_any_text_is_a_token_or_refused_without_being_repeated(text):
    try:
        assert str(tokens.parse(text)) == text.strip()
    except InputError as err:
        assert len(text.strip()) < 8 or text.strip() not in str(err)  # noqa: PT017 - it may be a secret, mistyped


@pytest.mark.parametrize(
    "text",
    [
        f"ann.{SECRET}", f"ann.{SECRET}.{PRINT}.more", f"ann.{SECRET[1:]}.{PRINT}", f"ann.{SECRET}.{PRINT}x",
        f".{SECRET}.{PRINT}", f"-ann.{SECRET}.{PRINT}", f"{'a' * 41}.{SECRET}.{PRINT}", f"a:b.{SECRET}.{PRINT}",
        f"ann.{SECRET}\n.{PRINT}", f"ann.{SECRET[:-1]}é.{PRINT}", f"änn.{SECRET}.{PRINT}",
    ],
)  # fmt: skip
def test_what_is_a_little_wrong_is_no_token(text):
    with pytest.raises(InputError, match=r"NAME\.SECRET\.FINGERPRINT") as found:
        tokens.parse(text)
    assert SECRET[:-1] not in str(found.value)


@given(named)
def test_a_name_of_a_token_is_one_that_tokens_are_read_with(name):
    assert tokens.check_name(name) == name


@pytest.mark.parametrize("name", ["", "-a", "_a", "a b", "a.b", "a:b", "a\n", "ä", "a" * 41, "a/b", "../a"])
def test_a_name_that_would_break_a_file_of_users_or_a_token_is_refused(name):
    with pytest.raises(InputError, match="up to 40 letters"):
        tokens.check_name(name)


def test_a_hash_fits_its_secret_alone_and_no_two_are_the_same():
    secret = tokens.text(secrets.token_bytes(32))
    first, second = tokens.hashed(secret), tokens.hashed(secret)
    assert first != second
    assert secret not in first
    assert tokens.fits(secret, first)
    assert not tokens.fits(secret + "x", second)


@pytest.mark.parametrize(
    "stored", ["", "x", "$argon2id$", "$argon2id$v=19$m=1$é", "plain", "\ud800", "$2b$12$abc", "é" * 90]
)
def test_what_is_no_hash_fits_nothing_and_breaks_nothing(stored):
    assert not tokens.fits("secret", stored)


@pytest.mark.parametrize("secret", ["", "\ud800", "x" * 100_000, "\0"])
def test_a_secret_of_any_characters_is_compared(secret):
    assert not tokens.fits(secret, tokens.hashed("another"))


@given(st.binary(max_size=200))
def test_a_fingerprint_fits_a_token_whatever_the_certificate(der):
    token = tokens.Token(name="a", secret=SECRET, fingerprint=tokens.fingerprint(der))
    assert tokens.parse(str(token)).fingerprint == tokens.fingerprint(der)
