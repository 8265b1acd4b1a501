"""What can go wrong with a project file, one small class per situation."""

from orient.errors import OrientError, ProjectError


class Locked(ProjectError):
    """Another command is writing the project."""


class DiskFull(ProjectError):
    """No space, or the file may not grow further."""


class Unreadable(ProjectError):
    """The system does not let the file be read, which says nothing about what is in it."""


class StorageError(ProjectError):
    """The disk reported an error."""


class ReadOnly(ProjectError):
    """The project or its folder cannot be written."""


class NeedsRecovery(ProjectError):
    """An interrupted command must be undone first, and the folder is read-only."""


class Replaced(ProjectError):
    """The file was replaced, or its schema changed, while this command waited."""


class ChangedMeanwhile(ProjectError):
    """Another command made a new version of what was read."""


class Corrupt(ProjectError):
    """The file is damaged."""


class Hostile(ProjectError):
    """The file holds something that orient never writes, or that takes too long to read."""


class OutOfMemory(OrientError):
    """The machine has less memory than this project needs (exit code 1); the file is not to blame."""


class Stopped(OrientError):
    """The user stopped the command; nothing was stored."""

    exit_code = 130


class OurFault(OrientError):
    """A mistake in orient itself."""

    exit_code = 70
