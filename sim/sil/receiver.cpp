#include "sim/sil/receiver.hpp"

#include <fstream>
#include <iterator>
#include <vector>

#include "fsw/base/crc.hpp"

namespace ilp::sil {

namespace fs = std::filesystem;

Receiver::Receiver(fs::path outbox, fs::path acknowledgements)
    : outbox_(std::move(outbox)), acknowledgements_(std::move(acknowledgements)) {}

void Receiver::receive() {
  for (const auto& entry : fs::directory_iterator(outbox_)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file() || entry.path().extension() == ".part" || seen_.count(name) != 0) continue;
    std::ifstream in(entry.path(), std::ios::binary);
    const std::vector<char> content((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(content.data());
    std::ofstream(acknowledgements_ / (name + ".ack"))
        << content.size() << " " << crc32({bytes, content.size()}) << "\n";
    seen_.insert(name);
    bytes_ += content.size();
  }
}

}  // namespace ilp::sil
