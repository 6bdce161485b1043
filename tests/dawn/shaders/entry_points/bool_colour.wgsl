// Dawn: refuses it: cannot apply '@location' to declaration of type 'bool'
@fragment fn fs() -> @location(0) bool {
    return true;
}
