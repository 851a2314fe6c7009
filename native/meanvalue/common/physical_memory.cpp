#include "meanvalue/common/physical_memory.h"

#include <algorithm>
#include <fstream>
#include <limits>

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#define NOMINMAX
#include <windows.h>
#else
#include <unistd.h>
#endif

namespace meanvalue {

std::uint64_t group_memory(const std::string& groups, const std::string& root) {
    std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
    const auto look = [&](const std::string& file) {
        std::ifstream limit(root + file);
        std::uint64_t bytes = 0;
        if (limit >> bytes) least = std::min(least, bytes);  // it says "max" where there is none
    };
    std::ifstream list(groups);
    for (std::string line; std::getline(list, line);) {  // NUMBER:CONTROLLERS:/GROUP, which is within those above it
        const std::size_t name = line.find(':');
        const std::size_t group = line.find(":/");
        if (group == std::string::npos) continue;
        const std::string controllers = line.substr(name, group - name);
        const bool is_old = controllers.find("memory") != std::string::npos;
        if (!is_old && controllers != ":") continue;
        for (std::string path = line.substr(group + 1);; path.erase(path.find_last_of('/'))) {
            look(is_old ? "/memory" + path + "/memory.limit_in_bytes" : path + "/memory.max");
            if (path.empty()) break;
        }
    }
    return least;
}

std::uint64_t physical_memory() {
#ifdef _WIN32
    MEMORYSTATUSEX status;
    status.dwLength = sizeof(status);
    if (GlobalMemoryStatusEx(&status) != 0) return status.ullTotalPhys;
#else
    const long pages = sysconf(_SC_PHYS_PAGES);
    const long page_size = sysconf(_SC_PAGESIZE);
    if (pages > 0 && page_size > 0) {
        return std::min(static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_size),
                        group_memory("/proc/self/cgroup", "/sys/fs/cgroup"));
    }
#endif
    return std::numeric_limits<std::uint64_t>::max();
}

}  // namespace meanvalue
