#include "sim/ground/report/reference_files.hpp"

#include <stdexcept>
#include <system_error>

#include "sim/host/image_io.hpp"
#include "sim/host/reference_cameras.hpp"
#include "sim/host/safe_name.hpp"

namespace ilp::report {

ReferenceFiles::ReferenceFiles(const std::filesystem::path& poses, std::filesystem::path depth_folder)
    : depth_folder_(std::move(depth_folder)) {
  for (const host::ReferenceCamera& camera : host::read_reference_cameras(poses)) {
    const bool added =
        poses_.emplace(host::stem(host::safe_name(camera.name)), ReferencePose{camera.cam_from_world, camera.centre})
            .second;
    if (!added) {
      throw std::runtime_error("reference poses " + poses.string() + ": '" + camera.name +
                               "' and another name differ only in their extension");
    }
  }
}

const ReferencePose* ReferenceFiles::pose(const std::string& name) const {
  const auto found = poses_.find(host::stem(name));
  return found == poses_.end() ? nullptr : &found->second;
}

host::Raster<float> ReferenceFiles::depth(const std::string& name) const {
  if (depth_folder_.empty()) return {};
  for (const std::string& base : {host::stem(name), name}) {
    const std::filesystem::path path = depth_folder_ / (base + ".pfm");
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) continue;
    return host::read_pfm(path);
  }
  return {};
}

}  // namespace ilp::report
