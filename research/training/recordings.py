"""Which recordings a clip was made from, by its name.

A network that is to be measured on a clip must not be fitted to the clip's recordings.
"""

# Clips made from one recording begin with one of these.
PREFIXES = ("stress_redboat", "redboat", "uav123_group1", "uav123_truck4", "uav123_wakeboard")
# Clips that compose_clips.py composed, and clips of the simulator.
COMPOSED, SIMULATED = "composed_", "sim_"
# Stands for a recording in the name of a composed clip whose target or pictures were made from stills.
STILL = "still"


def recording_of(clip):
    """The recording of a recorded clip. A composed or simulated clip is its own."""
    for prefix in PREFIXES:
        if clip.startswith(prefix):
            return prefix.removeprefix("stress_")
    return clip


def recordings_of(clip):
    """All recordings that a clip was made from."""
    if clip.startswith(SIMULATED):
        return set()
    if clip.startswith(COMPOSED):
        return set(clip.removeprefix(COMPOSED).split("+")[:2])
    return {recording_of(clip)}


def is_recorded(clip):
    return not clip.startswith((COMPOSED, SIMULATED))
