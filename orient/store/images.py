"""Embedded images: their bytes part by part, and whether these are still the file that was embedded."""

import hashlib
from collections.abc import Iterator
from typing import Any

from sqlalchemy import Connection

from orient.errors import ProjectError

IMAGES = "SELECT run_id, name, size_bytes, sha256, n_parts FROM main.image"
PART = "SELECT content FROM main.image_part WHERE run_id = ? AND seq = ?"


def image_bytes(connection: Connection, run_id: int) -> Iterator[bytes]:
    """The parts of an embedded image in their order. After the last one `ProjectError` if they are not the file."""
    row = connection.exec_driver_sql(f"{IMAGES} WHERE run_id = ?", (run_id,)).one()
    digest, size = hashlib.sha256(), 0
    for seq in range(1, row.n_parts + 1):
        part = connection.exec_driver_sql(PART, (run_id, seq)).scalar()
        if not isinstance(part, bytes):
            break
        digest.update(part)
        size += len(part)
        yield part
    if (size, digest.hexdigest()) != (row.size_bytes, row.sha256):
        raise ProjectError(f"run {run_id}: the embedded image is not the file that its digest names.")


def broken_images(connection: Connection) -> Iterator[str]:
    """Embedded images whose parts do not give size and SHA-256 of the file; parts too many."""
    for row in connection.exec_driver_sql(f"{IMAGES} ORDER BY run_id").all():
        if complaint := _complaint(connection, row):
            yield complaint


def _complaint(connection: Connection, row: Any) -> str:
    counted = "SELECT count(*) FROM main.image_part WHERE run_id = ?"
    count = connection.exec_driver_sql(counted, (row.run_id,)).scalar_one()
    if count != row.n_parts:
        return f"run {row.run_id}: the image has {count} parts, {row.n_parts} are told"
    if row.n_parts == 0:
        return ""
    try:
        for _ in image_bytes(connection, row.run_id):
            pass
    except ProjectError as error:
        return error.message.rstrip(".")
    return ""


def broken_manifests(connection: Connection) -> Iterator[str]:
    """Manifests that tell other digests than the ledger holds, or another image."""
    query = """
        SELECT m.run_id, m.sealed_run_id FROM main.sealed_run AS m
        LEFT JOIN main.run_seal AS s ON s.run_id = m.sealed_run_id
        WHERE (m.output_digest, m.record_digest, m.status) IS NOT (s.output_digest, s.record_digest, s.status)
        ORDER BY m.run_id, m.sealed_run_id
    """
    for run_id, sealed in connection.exec_driver_sql(query).all():
        yield f"run {run_id}: the manifest tells other digests of run {sealed} than the ledger"
    query = """
        SELECT m.run_id FROM main.sealed_file AS m
        WHERE m.image_sha256 IS NOT NULL AND m.image_sha256 NOT IN (SELECT sha256 FROM main.image) ORDER BY m.run_id
    """
    for run_id in connection.exec_driver_sql(query).scalars().all():
        yield f"run {run_id}: the manifest tells of an image that is not in the file"
