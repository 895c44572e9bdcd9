"""The certificate by which a robot shows who it is."""

import datetime as dt

import pytest
from cryptography import x509

from lbr.bus import certificates


@pytest.mark.parametrize("year", [1971, 2000, 2026, 2047, 2500])
def test_a_certificate_is_valid_whatever_a_machine_takes_for_the_date(year):
    _, pem = certificates.self_signed()
    found = x509.load_pem_x509_certificate(pem)
    assert found.not_valid_before_utc <= dt.datetime(year, 1, 1, tzinfo=dt.UTC) <= found.not_valid_after_utc
