// A simulated flight as files: images as a camera would deliver them, and the truth to measure against.
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

// How the files are written, frame by frame.

/// Name of the files of the frame with this number, counted from 1, without folder and extension: 0001.
[[nodiscard]] std::string frame_stem(std::size_t number);

/// Creates the folder with
///   cameras.txt              the intrinsics, COLMAP's text format
///   scenario.ini             the scenario as flown
///   navigation.csv           what the sensors of the vehicle measure, if it has some; a flight may read it while its
///                            images are rendered
void begin_flight_files(const std::filesystem::path& dir, const Scenario& scenario, const Terrain& terrain);
///   images/0001.pgm ...      the frames
///   truth/depth/0001.pfm ... z-depth in metres of every pixel of the image as taken (distortion included); 0 where a
///                            cloud hides the ground
/// Safe to call from several threads for different frames.
void write_flight_frame(const std::filesystem::path& dir, std::size_t number, const RenderedFrame& frame);
///   truth/poses.txt          name width height fx fy cx cy R(9) C(3) per frame, x_cam = R (X - C); metres, z up
///   truth/...                what follows from poses and depths: write_truth (truth.hpp)
///   index.txt                a line `time_ns images/NNNN.pgm` per frame; with flight.altimeter also the height of the
///                            camera above the ground straight below, m. Last, so that it stands for a complete flight.
void end_flight_files(const std::filesystem::path& dir, const Scenario& scenario, const Terrain& terrain,
                      const std::vector<CameraState>& states, std::size_t threads);

/// Height of the camera above the ground straight below, m.
[[nodiscard]] double height_above_ground(const Terrain& terrain, const CameraState& state);

/// `progress(done, total)` is called once per frame, one call at a time, possibly from another thread; it may be empty.
/// An exception that it throws ends the rendering and is passed on.
using RenderProgress = std::function<void(int done, int total)>;

/// Refuses what render_flight refuses, without writing anything: std::invalid_argument or, for files of the world,
/// std::runtime_error.
void check_scenario(const Scenario& scenario);

/// Writes into `dir`, which is created:
///   images/0001.pgm ...      the frames
///   index.txt                a line `time_ns images/NNNN.pgm` per frame; with flight.altimeter also the height of the
///                            camera above the ground straight below, m
///   cameras.txt              the intrinsics, COLMAP's text format
///   scenario.ini             the scenario as flown
///   truth/poses.txt          name width height fx fy cx cy R(9) C(3) per frame, x_cam = R (X - C); metres, z up
///   truth/depth/0001.pfm ... z-depth in metres of every pixel of the image as taken (distortion included); 0 where a
///                            cloud hides the ground
///   truth/...                what follows from these: write_truth (truth.hpp)
/// The same scenario gives the same bytes for any number of threads (0: as many as the host has). std::invalid_argument
/// or std::runtime_error says what is wrong; a flight too low over its ground or with the horizon in view is refused
/// before anything is rendered.
void render_flight(const std::filesystem::path& dir, const Scenario& scenario, const RenderProgress& progress = {},
                   std::size_t threads = 0);

}  // namespace ilp::world
