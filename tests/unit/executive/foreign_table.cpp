// Compiled by a test: with ILP_OWN_TABLE it has to compile, without it the compiler has to refuse it.

#include "fsw/imaging/acquisition.hpp"

namespace ilp {

#ifdef ILP_OWN_TABLE
using Written = FrameRecord;
#else
using Written = KeyframeRecord;
#endif

Status write(Acquisition::Tables store) {
  Written record;
  return put(store, record);
}

}  // namespace ilp
