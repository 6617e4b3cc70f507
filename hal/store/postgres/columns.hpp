// Converts between a record and a row of its table: the columns of its fields, followed by its checksum.
#pragma once

#include "fsw/records/field.hpp"
#include "hal/store/postgres/parameters.hpp"
#include "hal/store/postgres/rows.hpp"

namespace ilp::postgres {

/// Adds all columns of a record to the parameters. They point to the texts in `record`.
void bind_record(const RecordInfo& info, const void* record, Parameters& parameters);
/// Reads a record from a row. Returns false if a value does not fit its field or the checksum is wrong; the content of
/// `record` is then undefined.
[[nodiscard]] bool read_record(const RecordInfo& info, const Rows& rows, int row, void* record);
/// Copies a record as it will be read after a put: texts end at their terminator, and -0 becomes 0.
void canonical_record(const RecordInfo& info, const void* record, void* as_read);

}  // namespace ilp::postgres
