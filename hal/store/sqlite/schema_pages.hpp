// Restores the pages of a database's schema, without which nothing in the database can be read.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

/// Replaces unreadable schema pages of `damaged` by those of `fresh`, an empty database of the same build. No process
/// may have either open. A file without any valid page checksum was not written by this software and is not changed.
/// Returns `io_error` (a = errno) if a page cannot be read for a reason other than damage, or cannot be written.
Status restore_schema_pages(const char* damaged, const char* fresh);

}  // namespace ilp
