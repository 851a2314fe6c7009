#include "meanvalue/sequence/run.h"

namespace meanvalue {

void Run::finish() {
    std::vector<float*>().swap(shapes);
    std::vector<Seam::Shape>().swap(aside);
    std::vector<char>().swap(is_solved);
}

}  // namespace meanvalue
