// Writes a simulated flight as files: the images of the camera, the vehicle's measurements, and the truth.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/world/renderer.hpp"
#include "sim/world/scenario.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

// Functions that write the files frame by frame.

/// Name of the files of the frame with this number (from 1), without folder and extension: 0001.
[[nodiscard]] std::string frame_stem(std::size_t number);

/// Creates the folder with
///   cameras.txt              the intrinsics, COLMAP's text format
///   scenario.ini             the scenario as flown
///   navigation.csv           measurements of the vehicle's sensors, if it has any; written first because a flight may
///                            read them while its images are rendered
void begin_flight_files(const std::filesystem::path& dir, const Scenario& scenario, const Terrain& terrain);
/// Writes
///   images/0001.pgm ...      the frame
///   truth/depth/0001.pfm ... z-depth in metres of every pixel of the image as taken (distortion included); 0 where a
///                            cloud hides the ground
/// Thread-safe for different frames.
void write_flight_frame(const std::filesystem::path& dir, std::size_t number, const RenderedFrame& frame);
/// Writes
///   truth/poses.txt          name width height fx fy cx cy R(9) C(3) per frame, x_cam = R (X - C); metres, z up
///   truth/...                files derived from poses and depths: write_truth (truth.hpp)
///   index.txt                a line `time_ns images/NNNN.pgm` per frame; with flight.altimeter also the height of the
///                            camera above the ground straight below, m. Written last: it marks a complete flight.
void end_flight_files(const std::filesystem::path& dir, const Scenario& scenario, const Terrain& terrain,
                      const std::vector<CameraState>& states, std::size_t threads);

/// Height of the camera above the ground straight below, m.
[[nodiscard]] double height_above_ground(const Terrain& terrain, const CameraState& state);

/// Called after each frame, never concurrently, possibly from another thread; may be empty. An exception that it throws
/// ends the rendering and is passed to the caller of render_flight.
using RenderProgress = std::function<void(int done, int total)>;

/// Throws for the scenarios that render_flight refuses, without writing anything: std::invalid_argument, or
/// std::runtime_error for files of the world.
void check_scenario(const Scenario& scenario);

/// Renders a flight. Creates `dir` and writes
///   images/0001.pgm ...      the frames
///   index.txt                a line `time_ns images/NNNN.pgm` per frame; with flight.altimeter also the height of the
///                            camera above the ground straight below, m
///   cameras.txt              the intrinsics, COLMAP's text format
///   scenario.ini             the scenario as flown
///   navigation.csv           measurements of the vehicle's sensors, if it has any
///   truth/poses.txt          name width height fx fy cx cy R(9) C(3) per frame, x_cam = R (X - C); metres, z up
///   truth/depth/0001.pfm ... z-depth in metres of every pixel of the image as taken (distortion included); 0 where a
///                            cloud hides the ground
///   truth/...                files derived from these: write_truth (truth.hpp)
/// The same scenario gives the same bytes for any number of threads (0: one per core). Throws std::invalid_argument or
/// std::runtime_error that says what is wrong. A flight that is too low or has the horizon in view is refused before
/// rendering begins.
void render_flight(const std::filesystem::path& dir, const Scenario& scenario, const RenderProgress& progress = {},
                   std::size_t threads = 0);

}  // namespace ilp::world
