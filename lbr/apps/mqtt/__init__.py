"""The robot by MQTT: it reports its state, and does the words that its row allows, and nothing else.

`words` are what may be asked, `report` what is told, `shadow` the documents of an AWS IoT device shadow, `discovery`
those of Home Assistant; none of these knows network or bus. `session` is the connection, in a thread of its own, and
`capability` moves the robot, by leases as anyone does.
"""

from lbr.component import Component

COMPONENT = Component(
    kinds={"mqtt": "lbr.apps.mqtt.kind:KIND"},
    messages=("lbr.apps.mqtt.messages",),
)
