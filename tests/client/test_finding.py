"""At which of its addresses a robot of the network is reached."""

from ipaddress import ip_interface

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.client.finding import near

ADDRESSES = st.ip_addresses().map(str)


@pytest.mark.parametrize(
    ("told", "here", "reached"),
    [
        (["192.168.1.20"], ["192.168.1.7/24"], "192.168.1.20"),
        (["192.168.1.20", "10.9.0.1"], ["10.9.0.2/24"], "10.9.0.1"),
        (["10.0.2.15", "10.9.0.1"], ["127.0.0.1/8", "10.0.2.15/24", "10.9.0.2/24"], "10.9.0.1"),
        (["192.168.1.20", "fd00::1"], ["fd00::2/64"], "fd00::1"),
        (["192.168.1.20", "10.9.0.1"], ["172.16.0.2/16"], "192.168.1.20"),
        (["192.168.1.7", "10.9.0.1"], ["192.168.1.7/24", "10.9.0.1/24"], "192.168.1.7"),
        (["192.168.1.20"], [], "192.168.1.20"),
    ],
)
def test_a_robot_of_several_networks_is_reached_in_the_one_that_is_ours(told, here, reached):
    assert near(told, [ip_interface(one) for one in here]) == reached


@given(st.lists(ADDRESSES, min_size=1), st.lists(ADDRESSES))
def test_whatever_networks_there_are_it_is_one_of_the_addresses_that_were_told(told, here):
    assert near(told, [ip_interface(one) for one in here]) in told
