// Makes SQL statements from the field tables.
#pragma once

#include <cstdint>

#include "fsw/base/text.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

using SqlText = FixedText<6144>;

/// The statement that creates the table of a record; hal/store/sql_columns.hpp has the columns. The table of a blob is
/// `record_name(id, checksums, data)`; `checksums` is a sequence of u32, one for each chunk of `data`.
void create_table(const RecordInfo& info, SqlText& sql);
void insert_or_update(const RecordInfo& info, SqlText& sql);
/// The statement that selects all columns, with `where` appended.
void select(const RecordInfo& info, const char* where, SqlText& sql);

/// A number that is different if any field of any table is different.
[[nodiscard]] std::int32_t schema_fingerprint();

}  // namespace ilp
