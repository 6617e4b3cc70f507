// Reference poses from camera text files, true depths from PFM files.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "sim/ground/accuracy.hpp"

namespace ilp::ground {

/// One line per image, `#` starts a comment:
///   name width height fx fy cx cy r11 ... r33 Cx Cy Cz      with x_cam = R (X_world - C)
/// Names match with or without their extension. Depths are FOLDER/NAME.pfm.
class ReferenceFiles final : public Reference {
 public:
  /// `depth_folder` may be empty. Throws std::runtime_error with file and line when a line is not what is stated above.
  ReferenceFiles(const std::filesystem::path& poses, std::filesystem::path depth_folder);
  [[nodiscard]] const ReferencePose* pose(const std::string& name) const override;
  [[nodiscard]] Raster<float> depth(const std::string& name) const override;

 private:
  std::map<std::string, ReferencePose> poses_;  ///< by name without extension
  std::filesystem::path depth_folder_;
};

}  // namespace ilp::ground
