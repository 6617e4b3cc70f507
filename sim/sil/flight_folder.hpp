// The folder of a flight. No earlier flight is overwritten, and a start that failed or was interrupted does not block
// it.
#pragma once

#include <filesystem>

namespace ilp::sil {

/// Makes the folder ready for a new flight, or for one that goes on. A new flight needs a new or empty folder, or one
/// in which a flight was begun to be prepared and never flew: what that start left is removed. To resume, the folder
/// must hold a flight. std::runtime_error otherwise, with what to do.
void prepare_folder(const std::filesystem::path& out, bool resume);

/// The same for images and truth alone, which are written to OUT/flight. What else lies in OUT is left alone.
void prepare_render_folder(const std::filesystem::path& out);

/// From now on the folder holds a flight, or complete images, that nothing overwrites.
void flight_has_begun(const std::filesystem::path& out);
void images_are_complete(const std::filesystem::path& out);

}  // namespace ilp::sil
