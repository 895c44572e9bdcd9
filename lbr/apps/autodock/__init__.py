"""`autodock`: finds the charging dock, backs onto its contacts and sees that the battery is being charged.

`script` decides, and knows neither bus nor clock; `pilot` moves the robot as it says.
"""
