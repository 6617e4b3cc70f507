// Restores the pages of a database's schema, without which nothing else in it can be read.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

/// Replaces the unreadable ones of `damaged` by those of `fresh`, an empty database of the same build that no process
/// has open. A file in which no page has a right checksum is no database of ours and is left alone. `io_error` (a =
/// errno): one could not be read, which is no reason to replace it, or not be written.
Status restore_schema_pages(const char* damaged, const char* fresh);

}  // namespace ilp
