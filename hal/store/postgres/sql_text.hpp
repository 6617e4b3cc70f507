// The SQL text for the field tables, as PostgreSQL takes it.
#pragma once

#include <cstdint>

#include "fsw/base/text.hpp"
#include "fsw/records/field.hpp"

namespace ilp::postgres {

using SqlText = FixedText<12288>;

/// What is done with a record. Parameters are $1, $2, ... in the order given here.
enum class RowVerb : std::uint8_t {
  put,    ///< all columns
  get,    ///< id
  next,   ///< id before, most rows
  last,   ///< none
  erase,  ///< id
  count,  ///< none
  end
};

/// What is done with one of its blobs.
enum class BlobVerb : std::uint8_t {
  resize,  ///< id, bytes: zero bytes, unless the blob has this size
  fill,    ///< id, bytes, checksums, data
  read,    ///< id, most bytes of data
  erase,   ///< id
  end
};

/// hal/store/sql_columns.hpp has the columns. The table of a blob is `record_name(id, bytes, checksums, data)`;
/// `checksums` is a sequence of u32, one for each chunk of `data`. Both are empty for a blob of zeros.
void create_table(const RecordInfo& info, SqlText& sql);
void create_blob_table(const RecordInfo& info, const FieldInfo& field, SqlText& sql);
void keep_blob_external(const RecordInfo& info, const FieldInfo& field, SqlText& sql);

void row_statement(RowVerb verb, const RecordInfo& info, SqlText& sql);
/// `field` is the blob.
void blob_statement(BlobVerb verb, const RecordInfo& info, const FieldInfo& field, SqlText& sql);

/// The table `ilp_store` has one row: the fingerprint of the schema, the number of commits that changed something, and
/// for each table the number of the commit that changed it last.
void create_store_table(SqlText& sql);
void fill_store_table(SqlText& sql);
/// Selects `commits` and the numbers of all tables, in the order of RecordType.
void look_at_changes(SqlText& sql);
/// Parameters: mask of the changed tables; 1 to notify. Returns the number of the commit.
void note_changes(SqlText& sql);
/// Bytes of all blobs and of the pages of all tables.
void used_bytes(SqlText& sql);

/// A number that changes with any field of any table.
[[nodiscard]] std::int64_t schema_fingerprint();

}  // namespace ilp::postgres
