// What a run kept of a map, and cannot be read back.
#pragma once

#include <stdexcept>

namespace ilp::map {

/// what() says which part it is. Whoever knows the file of the catalogue, or of the package with a copy of the part,
/// catches it and names that.
struct DamagedCatalogue : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace ilp::map
