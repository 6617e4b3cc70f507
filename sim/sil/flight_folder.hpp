// Prepares the folder of a flight, so that no earlier flight is overwritten, and so that a failed or interrupted start
// can be repeated.
#pragma once

#include <filesystem>

namespace ilp::sil {

/// Makes the folder ready for a new flight, or checks it for `resume`. For a new flight the folder must be new, empty,
/// or left by a start that never flew; the files of such a start are removed. For `resume` the folder must contain a
/// flight. Throws std::runtime_error otherwise, with advice.
void prepare_folder(const std::filesystem::path& out, bool resume);

/// Makes OUT/flight ready for images and truth without a flight. Other files in OUT are not touched. Throws
/// std::runtime_error if OUT/flight is not empty.
void prepare_render_folder(const std::filesystem::path& out);

/// Marks the folder as one with a flight, or with complete images, that later starts do not overwrite.
void flight_has_begun(const std::filesystem::path& out);
void images_are_complete(const std::filesystem::path& out);

}  // namespace ilp::sil
