#include "sim/tools/campaign/campaign_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "sim/host/files.hpp"

namespace ilp::batch {
namespace fs = std::filesystem;
namespace {

constexpr const char* name_file = "campaign-name.txt";

void check_owner(const Campaign& campaign, const fs::path& folder) {
  if (!fs::exists(folder) || (fs::is_directory(folder) && fs::is_empty(folder))) return;
  if (!fs::is_regular_file(folder / name_file)) {
    throw std::runtime_error(folder.string() +
                             " holds other things: expected a new or empty folder, or this campaign's");
  }
  const std::vector<std::uint8_t> bytes = ground::read_file(folder / name_file);
  std::string owner(bytes.begin(), bytes.end());
  while (!owner.empty() && owner.back() == '\n') owner.pop_back();
  if (owner != campaign.name) {
    throw std::runtime_error(folder.string() + " holds the campaign \"" + owner + "\", not \"" + campaign.name + "\"");
  }
}

}  // namespace

CampaignFolder::CampaignFolder(const Campaign& campaign, const fs::path& folder) : path_(fs::absolute(folder)) {
  check_owner(campaign, path_);
  ground::make_output_folder(path_);
  ground::write_file(path_ / name_file, campaign.name + "\n");
  ground::make_output_folder(path_ / "jobs");
  const fs::path lock_file = path_ / ".lock";
  lock_ = open(lock_file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (lock_ < 0) throw std::runtime_error("cannot write " + lock_file.string() + ": " + std::strerror(errno));
  if (flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    close(lock_);
    throw std::runtime_error("another run of this campaign works in " + path_.string());
  }
  ground::write_file(path_ / "campaign.ini", ground::read_file(campaign.file));
}

CampaignFolder::~CampaignFolder() {
  if (lock_ >= 0) close(lock_);
}

}  // namespace ilp::batch
