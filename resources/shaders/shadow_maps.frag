#version 330 core
// Nothing but the depth of what a light sees.

void main()
{
}
