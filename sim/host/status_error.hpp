// Flight statuses as host errors.
#pragma once

#include <string>

#include "fsw/base/status.hpp"

namespace ilp::host {

/// The text of the status list with its values filled in.
[[nodiscard]] std::string status_sentence(const Status& status);
/// The same, and what to do.
[[nodiscard]] std::string describe(const Status& status);
/// Throws std::runtime_error("WHAT: ...") unless the status is ok.
void require(const Status& status, const std::string& what);

}  // namespace ilp::host
