// The pages of a database that hold its schema, without which nothing else of it can be read.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

/// Those of `damaged` that cannot be read are taken from `fresh`, an empty database of the same build that nobody has
/// open. A file in which no page has its checksum is no database of ours and left alone. `io_error` (a = errno).
Status restore_schema_pages(const char* damaged, const char* fresh);

}  // namespace ilp
