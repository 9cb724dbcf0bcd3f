// Words of the page /docs; what it describes is the server's.
export const words = {
  title: 'The interface', loading: 'Asking the server …', absent: 'The server does not answer.', token: 'This server asks for a token', use: 'Use it',
  contents: 'Contents', home: 'Back to the page', search: 'Search', parameters: 'Parameters', raw: 'The same for programs:', headers: 'Headers',
  allParameters: (count: number) => `and ${count} parameters of fractures`, body: 'Body:',
};
