// poses_of_a_folder FOLDER/*.pgm: positions of the cameras, in units of the distance of the first two.
#include "fsw/vision/multiview/sequence.hpp"
#include "fsw/vision/multiview/sequence_workspace.hpp"
#include "matching.hpp"

using namespace ilp;

void print_final(Sequence& sequence, char** files) {
  for (SequenceCamera c; sequence.take_final_camera(c);) {
    const double* x = c.pose.centre;
    std::printf("%s %.9g %.9g %.9g\n", files[c.keyframe_id], x[0], x[1], x[2]);
  }
  FinalPoint point;
  while (sequence.take_final_point(point)) continue;
}

int main(int count, char** names) {
  const auto state = std::make_unique<SequenceState>();
  const auto workspace = std::make_unique<SequenceWorkspace>();
  Sequence sequence(*state, *workspace);
  check(sequence.begin_strip(camera, {}), "camera");
  Picture<std::uint8_t> before;
  Corners corners_before;
  for (int i = 1; i < count; ++i) {
    auto image = read_pgm(names[i]);
    Corners corners = corners_of(image.view());
    Matches matches;
    if (i > 1) matches = matches_of(before.view(), corners_before, image.view(), corners);
    SequenceReport report;
    check(sequence.add_keyframe(i, corners, matches, 7, report), names[i]);
    print_final(sequence, names);
    refine_corners(matches, corners);  // positions chain along a track
    before = image;
    corners_before = corners;
  }
  check(sequence.flush(), "end of the strip");
  print_final(sequence, names);
}
