#include "bsp/version/build_version.hpp"

#include "commit.inc"

namespace ilp {

const char* build_commit() {
  return ILP_COMMIT;
}

}  // namespace ilp
