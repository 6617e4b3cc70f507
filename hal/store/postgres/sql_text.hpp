// Writes the SQL statements of the store in PostgreSQL's dialect.
#pragma once

#include <cstdint>

#include "fsw/base/text.hpp"
#include "fsw/records/field.hpp"

namespace ilp::postgres {

using SqlText = FixedText<12288>;

/// Statements on the rows of a table. The comments list their parameters $1, $2, ...
enum class RowVerb : std::uint8_t {
  put,    ///< all columns
  get,    ///< id
  next,   ///< id after which rows are wanted, limit of rows
  last,   ///< no parameters
  erase,  ///< id
  count,  ///< no parameters
  end     ///< number of verbs
};

/// Statements on the blobs of a field.
enum class BlobVerb : std::uint8_t {
  resize,  ///< id, bytes: fills the blob with zeros, unless it has this size
  fill,    ///< id, bytes, checksums, data
  read,    ///< id, limit of data bytes
  erase,   ///< id
  end      ///< number of verbs
};

/// Write the definitions of tables. hal/store/sql_columns.hpp has the columns of a record. The table of a blob field is
/// `record_name(id, bytes, checksums, data)`, where `checksums` has a u32 for each chunk of `data`. Both are empty for
/// a blob of zeros. keep_blob_external() switches the server's compression of blobs off.
void create_table(const RecordInfo& info, SqlText& sql);
void create_blob_table(const RecordInfo& info, const FieldInfo& field, SqlText& sql);
void keep_blob_external(const RecordInfo& info, const FieldInfo& field, SqlText& sql);

void row_statement(RowVerb verb, const RecordInfo& info, SqlText& sql);
/// `field` is a blob field.
void blob_statement(BlobVerb verb, const RecordInfo& info, const FieldInfo& field, SqlText& sql);

/// Make and fill the table `ilp_store`. It has one row: the fingerprint of the schema, the number of commits with
/// changes, and for each table the number of the commit that changed it last.
void create_store_table(SqlText& sql);
void fill_store_table(SqlText& sql);
/// Selects the number of commits and the numbers of all tables, in the order of RecordType.
void look_at_changes(SqlText& sql);
/// Counts a commit, and selects its number. Parameters: RecordMask of the changed tables; 1 to notify other processes,
/// else 0.
void note_changes(SqlText& sql);
/// Selects the bytes of all blobs and of the pages of all tables.
void used_bytes(SqlText& sql);

/// table_fingerprint() of this dialect.
[[nodiscard]] std::int64_t schema_fingerprint();

}  // namespace ilp::postgres
