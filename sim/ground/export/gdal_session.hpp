// GDAL set up once for all writers of this folder; its messages become exceptions instead of lines on the terminal.
#pragma once

#include <gdal_priv.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

namespace ilp::exports {

/// Registers the drivers, bounds the block cache, and catches messages while it lives.
class GdalSession {
 public:
  GdalSession();
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

/// Takes the finished file for the whole; throws std::runtime_error.
void move_into_place(const std::filesystem::path& part, const std::filesystem::path& whole);

}  // namespace ilp::exports
