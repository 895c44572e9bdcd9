"""Tokens are hashes with a role, a name of their own and perhaps an end."""

import pytest

from lbr.database.store import Database
from lbr.errors import InputError, RowError
from tests.support import databases

HASH = "h" * 64


def test_a_token_is_good_for_both_ways_in_unless_it_says_which(database):
    for good_for in ("bus", "web", "both"):
        database.add_token(databases.token(good_for, "view", HASH, good_for=good_for))
    database.add_token(databases.token("phone", "view", HASH))
    assert {one.name: (one.lets_in("bus"), one.lets_in("web")) for one in database.tokens()} == {
        "bus": (True, False),
        "web": (False, True),
        "both": (True, True),
        "phone": (True, True),
    }


def test_a_token_is_told_to_other_programs_while_this_one_runs(database, path):
    database.add_token(databases.token("phone", "operate", HASH, "2027-01-01T00:00:00.000Z"))
    with Database.open(path) as other:
        (token,) = other.tokens()
    assert (token.name, token.role, token.hash, token.revoked_at) == ("phone", "operate", HASH, None)
    assert token.expires_at == "2027-01-01T00:00:00.000Z"
    assert token.created_at.endswith("Z")


def test_a_name_is_taken_until_it_is_revoked(database):
    database.add_token(databases.token("phone", "operate", HASH))
    with pytest.raises(InputError, match="there is a token 'phone' already"):
        database.add_token(databases.token("phone", "view", "i" * 64))
    database.revoke_token("phone")
    assert database.tokens()[0].revoked_at is not None
    database.add_token(databases.token("phone", "view", "i" * 64))
    assert [(token.role, token.hash, token.revoked_at) for token in database.tokens()] == [("view", "i" * 64, None)]


def test_only_a_valid_token_can_be_revoked(database):
    database.add_token(databases.token("phone", "operate", HASH))
    database.revoke_token("phone")
    for name in ("phone", "nobody"):
        with pytest.raises(InputError, match=f"no token '{name}'"):
            database.revoke_token(name)


@pytest.mark.parametrize(("name", "role", "hash_"), [("", "view", HASH), ("n", "god", HASH), ("n", "view", "plain")])
def test_what_is_no_token_is_refused(database, name, role, hash_):
    with pytest.raises(RowError):
        database.add_token(databases.token(name, role, hash_))
    assert database.tokens() == ()


def test_a_token_has_a_name_for_people_and_stays_as_it_is(database):
    database.add_token(databases.token("phone", "operate", HASH))
    database.rename_token("phone", "Ann\nin the kitchen")
    assert [(one.name, one.called, one.hash) for one in database.tokens()] == [("phone", "Ann in the kitchen", HASH)]


@pytest.mark.parametrize(("name", "called", "code"), [("nobody", "Ann", "unknown_name"), ("phone", " ", "bad_value")])
def test_a_name_for_people_needs_a_token_and_a_letter(database, name, called, code):
    database.add_token(databases.token("phone", "operate", HASH))
    with pytest.raises(InputError) as refused:
        database.rename_token(name, called)
    assert refused.value.code == code
    assert database.tokens()[0].called is None
