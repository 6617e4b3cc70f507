// The text that `--version` of a program prints.
#pragma once

#include <string>

#include "bsp/version/build_version.hpp"
#include "cfg/limits.hpp"
#include "cfg/version.hpp"

namespace ilp::host {

/// `ilp-sil 0.1.0, commit 0123456789ab, profile host`
[[nodiscard]] inline std::string version_line(const std::string& program) {
  return program + " " + software_version + ", commit " + build_commit() + ", profile " + limits::profile;
}

}  // namespace ilp::host
