// The exception for a part of a map that the catalogue holds and that cannot be read back.
#pragma once

#include <stdexcept>

namespace ilp::map {

/// what() says which part is damaged. A caller that knows the file (of the catalogue, or of the package with a copy of
/// the part) catches the exception and adds the file's name.
struct DamagedCatalogue : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace ilp::map
