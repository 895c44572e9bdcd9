"""The robot by MQTT: it reports its state, and does the words that its row allows, and nothing else.

`words` defines the words, `report` the report, `shadow` the documents of an AWS IoT device shadow, and `discovery`
those of Home Assistant. None of these knows network or bus. `session` is the connection, in a thread of its own, and
`capability` moves the robot under leases, as any other client does.
"""

from lbr.component import Component

COMPONENT = Component(kinds={"mqtt": "lbr.apps.mqtt.kind:KIND"}, messages=("lbr.apps.mqtt.messages",))
