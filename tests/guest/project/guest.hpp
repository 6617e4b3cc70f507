// What the examples share: pictures in files, and a fault that ends the program.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

/// The camera of the simulated images.
inline const ilp::CameraModel camera{640, 480, 550, 550, 319.5, 239.5, -0.08, 0.01, 0.0004, -0.0003};

inline void check(const ilp::Status& status, const char* what) {
  if (status.ok()) return;
  std::fprintf(stderr, "%s: %s (%lld, %lld)\n", what, ilp::status_name(status.code), static_cast<long long>(status.a),
               static_cast<long long>(status.b));
  std::exit(1);
}

template <typename T>
struct Picture {
  int width = 0, height = 0;
  std::vector<T> pixels;

  Picture() = default;
  Picture(int w, int h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  ilp::ImageView<T> view() { return {pixels.data(), width, height}; }
};

inline Picture<std::uint8_t> read_pgm(const std::string& name) {
  std::ifstream file(name, std::ios::binary);
  std::string magic;
  int width = 0, height = 0, most = 0;
  file >> magic >> width >> height >> most;
  file.get();
  Picture<std::uint8_t> picture(width, height);
  file.read(reinterpret_cast<char*>(picture.pixels.data()), static_cast<std::streamsize>(picture.pixels.size()));
  if (magic == "P5" && most == 255 && file) return picture;
  std::fprintf(stderr, "%s is no PGM picture of 8 bits\n", name.c_str());
  std::exit(1);
}

/// Little-endian, the last row first.
inline void write_pfm(const std::string& name, Picture<float>& picture) {
  std::ofstream file(name, std::ios::binary);
  file << "Pf\n" << picture.width << ' ' << picture.height << "\n-1\n";
  for (int y = picture.height - 1; y >= 0; --y) {
    const std::streamsize bytes = static_cast<std::streamsize>(sizeof(float)) * picture.width;
    file.write(reinterpret_cast<const char*>(picture.view().row(y)), bytes);
  }
}
