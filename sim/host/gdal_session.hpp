// Sets GDAL up for a process, keeps its messages off the terminal, and makes exceptions of them.
#pragma once

#include <gdal_priv.h>

#include <memory>
#include <stdexcept>
#include <string>

namespace ilp::host {

/// Registers drivers and bounds the block cache (64 MiB). GDAL prints no messages while the object exists. A program
/// that flies registers raster drivers only: some other drivers use SQLite on registration, before the flight could
/// configure it.
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

/// An exception with the text `what` and GDAL's last message.
[[nodiscard]] std::runtime_error gdal_error(const std::string& what);

}  // namespace ilp::host
