"""Attacks: kills, full disks, damaged libraries and damaged files, at random and without end.

    python -m tests.attack --minutes 10 [--part NAME ...] [--seed N]

Every attempt has its own random numbers, from the seed, the part and the attempt's number, so that one that finds a
fault can be repeated alone (``--part NAME --seed N --only NUMBER``). A part is a module of this package with ``PART``;
`test_attack` runs a few attempts of each.
"""
