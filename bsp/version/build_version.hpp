// Returns the commit from which a program was built; cfg/version.hpp has the version.
#pragma once

namespace ilp {

/// Returns the first 12 digits of the commit, such as `0123456789ab`. A `+` follows if the sources had uncommitted
/// changes. Returns `unknown` for sources without a repository.
[[nodiscard]] const char* build_commit();

}  // namespace ilp
