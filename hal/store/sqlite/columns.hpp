// A record as a row of its table: the columns of its fields, followed by its checksum.
#pragma once

#include "fsw/records/field.hpp"

struct sqlite3_stmt;

namespace ilp {

/// Binds all columns from the first parameter on.
void bind_record(sqlite3_stmt* statement, const RecordInfo& info, const void* record);
/// Reads the current row. False when a value does not fit its field, or the checksum is wrong: `record` then holds
/// nothing but perhaps its id.
[[nodiscard]] bool read_record(sqlite3_stmt* statement, const RecordInfo& info, void* record);

}  // namespace ilp
