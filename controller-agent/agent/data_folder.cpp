#include "agent/data_folder.hpp"

namespace headstock::agent {

DataFolder::DataFolder(std::filesystem::path folder) : folder_(std::move(folder)), lock_(folder_, "headstock-agent") {}

}  // namespace headstock::agent
