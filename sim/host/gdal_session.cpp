#include "sim/host/gdal_session.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>

#include <mutex>

namespace ilp::host {
namespace {

constexpr GIntBig cache_bytes = 64 << 20;

void set_up() {
  GDALSetCacheMax64(cache_bytes);
  // Everything stands in the file itself, nothing in an .aux.xml beside it.
  CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");
}

}  // namespace

GdalSession::GdalSession(void (*register_drivers)()) {
  static std::once_flag once;
  std::call_once(once, set_up);
  register_drivers();
  CPLPushErrorHandler(CPLQuietErrorHandler);
  CPLErrorReset();
}

GdalSession::~GdalSession() {
  CPLPopErrorHandler();
}

std::runtime_error gdal_error(const std::string& what) {
  const std::string message = CPLGetLastErrorMsg();
  return std::runtime_error(what + (message.empty() ? "" : ": " + message));
}

}  // namespace ilp::host
