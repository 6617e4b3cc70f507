// A record as a row of its table: the columns of its fields, followed by its checksum.
#pragma once

#include "fsw/records/field.hpp"
#include "hal/store/postgres/parameters.hpp"
#include "hal/store/postgres/rows.hpp"

namespace ilp::postgres {

/// Adds all columns. Texts stay in the record.
void bind_record(const RecordInfo& info, const void* record, Parameters& parameters);
/// False when a value does not fit its field, or the checksum is wrong: `record` then holds nothing but perhaps its id.
[[nodiscard]] bool read_record(const RecordInfo& info, const Rows& rows, int row, void* record);
/// The record as read_record() gives it after a put: texts end at their terminator, and -0 is 0.
void canonical_record(const RecordInfo& info, const void* record, void* as_read);

}  // namespace ilp::postgres
