// A simulated flight as files: images as a camera would deliver them, and the truth to measure against.
#pragma once

#include <filesystem>
#include <functional>

#include "sim/world/flight.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::sim {

/// Writes into `dir`, which is created:
///   images/0001.pgm ...      the frames
///   index.txt                a line `time_ns images/NNNN.pgm` per frame
///   cameras.txt              the intrinsics, COLMAP's text format
///   truth/poses.txt          name width height fx fy cx cy R(9) C(3) per frame, x_cam = R (X - C); metres, z up
///   truth/depth/0001.pfm ... z-depth in metres of every pixel of the image as taken (distortion included)
/// Same parameters, same bytes. `progress(done, total)` is called once per frame, one call at a time, possibly from
/// another thread; it may be empty. std::invalid_argument or std::runtime_error says what is wrong; what `progress`
/// throws ends the rendering and is passed on.
void render_flight(const std::filesystem::path& dir, const WorldParams& world, const FlightParams& flight,
                   const std::function<void(int done, int total)>& progress);

}  // namespace ilp::sim
