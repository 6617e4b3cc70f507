// The commit of which a program was built; cfg/version.hpp has the version.
#pragma once

namespace ilp {

/// `0123456789ab`; with a `+` behind it where the sources had changes that are not committed; `unknown` for sources
/// without a repository.
[[nodiscard]] const char* build_commit();

}  // namespace ilp
