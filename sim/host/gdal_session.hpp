// GDAL, set up once by a process; its messages become exceptions instead of lines on the terminal.
#pragma once

#include <gdal_priv.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace ilp::host {

/// Registers drivers, bounds the block cache, and catches messages while it lives. A program that flies registers the
/// drivers of rasters only: others use SQLite as soon as they are registered, and the flight configures it first.
class GdalSession {
 public:
  explicit GdalSession(void (*register_drivers)() = GDALAllRegister);
  ~GdalSession();
  GdalSession(const GdalSession&) = delete;
  GdalSession& operator=(const GdalSession&) = delete;
};

struct DatasetCloser {
  void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<GDALDataset, DatasetCloser>;

/// `what` with GDAL's last message.
[[nodiscard]] std::runtime_error gdal_error(const std::string& what);

}  // namespace ilp::host
